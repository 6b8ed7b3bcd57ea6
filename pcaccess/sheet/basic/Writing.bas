' The sheet Write: what stands in the yellow cells goes to the PLC when somebody presses the button.
Option Explicit

Global Const WRITE_SHEET = "Write"
Global Const FIRST_ROW = 6
Global Const ITEM = 0
Global Const NEW_VALUE = 2
Const RESULT = 3

Sub WriteNewValues
	' A value that was taken leaves its yellow cell; one that was refused stays, with the reason beside it.
	Dim oSheet As Object, oNew As Object, sItem As String, sValue As String, sWhy As String, nRow As Long, bAny As Boolean
	oSheet = ThisComponent.Sheets.getByName(WRITE_SHEET)
	For nRow = FIRST_ROW To UsedRows(oSheet) - 1
		sItem = oSheet.getCellByPosition(ITEM, nRow).String
		oNew = oSheet.getCellByPosition(NEW_VALUE, nRow)
		If sItem <> "" And oNew.Type <> com.sun.star.table.CellContentType.EMPTY Then
			sValue = NewText(oNew)
			sWhy = WriteItem(sItem, sValue)
			If sWhy = "" Then
				oSheet.getCellByPosition(RESULT, nRow).String = sValue & " written at " & Format(Now(), "HH:MM:SS")
				oNew.clearContents(1 + 2 + 4 + 16)
				bAny = True
			Else
				oSheet.getCellByPosition(RESULT, nRow).String = "not written: " & sWhy
			End If
		End If
	Next nRow
	If bAny And Setting("Running") = 1 Then Linked().refresh()
End Sub

Function NewText(oCell As Object) As String
	' As the gateway reads it: a point as decimal sign in every language.
	If oCell.Type = com.sun.star.table.CellContentType.TEXT Then
		NewText = oCell.String
	ElseIf oCell.Type = com.sun.star.table.CellContentType.FORMULA And oCell.FormulaResultType2 <> com.sun.star.sheet.FormulaResult.VALUE Then
		NewText = oCell.String
	Else
		NewText = Trim(Str(oCell.Value))
	End If
End Function

Function WriteItem(sItem As String, sValue As String) As String
	' Empty when the PLC has taken the value; otherwise why it has not.
	Dim sWhy As String, sCheck As String, sQuality As String, sPath As String
	sPath = "/api/items/" & Encoded(sItem)
	sWhy = HttpPut(sPath & "/value", sValue)
	If sWhy <> "" Then
		If HttpGet(sPath & "/check?value=" & Encoded(sValue), sCheck) = "" And sCheck <> "ok" Then
			sWhy = sCheck
			If InStr(sWhy, sItem) = 1 Then sWhy = Trim(Mid(sWhy, Len(sItem) + 1))
			If Left(sWhy, 1) = ":" Then sWhy = Trim(Mid(sWhy, 2))
		ElseIf HttpGet(sPath & "/quality", sQuality) = "" And sQuality <> "192" Then
			sWhy = sWhy & " (quality " & sQuality & ")"
		End If
	End If
	WriteItem = sWhy
End Function
